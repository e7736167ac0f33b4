"""What every test may import."""

import os
import sys
from pathlib import Path

# Before NumPy is loaded: matrices here are small, and threads that wait for each other on a busy machine take minutes
# over what one does in a second.
os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
sys.path.insert(0, str(Path(__file__).parent))
