"""The compiler of the slow loops of the studies; nothing but the studies and their own tests needs it."""

try:
    from numba import njit
except ImportError as absent:
    raise ImportError("compiled path tracking needs numba: pip install '.[study]'") from absent

__all__ = ["compiled"]

# Sums may be contracted and regrouped; nan and infinity keep their meaning, which no step accepts.
compiled = njit(cache=True, fastmath={"contract", "reassoc"}, error_model="numpy")
