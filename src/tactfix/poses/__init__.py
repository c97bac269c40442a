"""Every pose of a rigid fixture that explains its contacts, refined on all of them, with its uncertainty."""
