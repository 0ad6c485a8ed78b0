import faulthandler
import pathlib
import signal
import sys

sys.path.insert(0, str(pathlib.Path(__file__).parent))
# A computation that waits for ever fails.
faulthandler.dump_traceback_later(600, exit=True)
# Programs that a shell starts in the background ignore Ctrl-C.
signal.signal(signal.SIGINT, signal.default_int_handler)
