"""Put the helper modules of these tests on their path."""

import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parent))
