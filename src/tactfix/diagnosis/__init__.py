"""The mistakes that cells make, looked for where no pose explains the contacts."""
