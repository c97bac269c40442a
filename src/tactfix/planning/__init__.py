"""Planning of contacts: possible touches, their information, the optimal set, and the uniqueness of its pose."""
