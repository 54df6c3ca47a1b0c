"""How PGNs travel is known without knowing the messages."""

import subprocess
import sys


def test_who_reads_logs_need_not_import_the_declared_messages():
    """They are a quarter of what `timonel decode` would import before its first line."""
    program = "import sys, timonel.recording.decoding; print('timonel.nmea2000.registry' in sys.modules)"
    found = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, check=True)
    assert found.stdout == "False\n"
