"""A machine log as a contact file: CSV that locate reads without options."""

import csv
import io

import numpy as np

from tactfix.files.logs.load import LogContacts


def contact_csv(read: LogContacts) -> str:
    """The text of a contact file; tip_radius and sigma are left out where nothing said them.

    Numbers are written so that they read back as the same doubles; the log's line of each contact is its id where
    the log does not name it.
    """
    buffer = io.StringIO()
    for key, value in (("units", read.units), ("tip_radius", read.tip_radius), ("sigma", read.sigma)):
        if value is not None:
            buffer.write(f"# {key}: {value}\n")
    told = np.asarray(np.isfinite(read.approaches).all(axis=1))
    writer = csv.writer(buffer, lineterminator="\n")
    writer.writerow(["feature", "x", "y", "z", *(["ax", "ay", "az"] if told.any() else []), "id"])
    rows = zip(read.features, read.points.tolist(), read.approaches.tolist(), told, read.log.contacts, strict=True)
    for feature, point, approach, has_approach, contact in rows:
        cells = (approach if has_approach else [""] * 3) if told.any() else []
        writer.writerow([feature, *point, *cells, contact.id or f"line {contact.line}"])
    return buffer.getvalue()
