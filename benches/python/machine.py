"""Description of the machine of a measurement."""

import os
import platform
from pathlib import Path


def processor() -> str:
    """The processor's name, if Linux provides it."""
    try:
        lines = Path("/proc/cpuinfo").read_text().splitlines()
    except OSError:
        return platform.processor() or platform.machine()
    names = [line.split(":", 1)[1].strip() for line in lines if line.startswith("model name")]
    return names[0] if names else platform.machine()


def description() -> str:
    """Processor, cores, system, Python, and the current load of the machine."""
    system = f"{processor()}, {os.cpu_count()} cores, {platform.system()}, Python {platform.python_version()}"
    return f"{system}; load at the start: {os.getloadavg()[0]:.2f}"
