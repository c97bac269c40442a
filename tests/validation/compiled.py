"""The compiler (numba) for the slow loops of the studies; only the studies and their tests need it."""

try:
    from numba import njit
except ImportError as absent:
    raise ImportError("compiled path tracking needs numba: pip install '.[study]'") from absent

__all__ = ["compiled"]

# Sums may be contracted and reordered; nan and infinity must be kept, because steps are rejected by them.
compiled = njit(cache=True, fastmath={"contract", "reassoc"}, error_model="numpy")
