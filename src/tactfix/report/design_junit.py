"""The findings of design-check as JUnit XML, for CI systems."""

from xml.etree import ElementTree

from tactfix.design.design_report import DesignReport


def design_junit(report: DesignReport) -> str:
    """A test suite with one case for each finding: an error is a failure, a warning passes and is told."""
    suite = ElementTree.Element(
        "testsuite",
        name=f"tactfix design-check {report.fixture.name}",
        tests=str(len(report.findings)),
        failures=str(sum(finding.status == "error" for finding in report.findings)),
        errors="0",
        skipped="0",
    )
    for finding in report.findings:
        classname = f"tactfix.design-check.{report.fixture.name}"
        case = ElementTree.SubElement(suite, "testcase", classname=classname, name=finding.code)
        if finding.status == "error":
            failure = ElementTree.SubElement(case, "failure", message=finding.message, type=finding.code)
            failure.text = finding.hint
        else:
            told = "\n".join(part for part in (f"{finding.status}: {finding.message}", finding.hint) if part)
            ElementTree.SubElement(case, "system-out").text = told
    ElementTree.indent(suite)
    return ElementTree.tostring(suite, encoding="unicode", xml_declaration=True) + "\n"
