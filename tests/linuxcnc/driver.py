#!/usr/bin/python3
"""In place of a screen: switches the machine on, homes it, runs programs one after the other and logs each.

PRECOMP_JOBS names the jobs, one a line: program, tab, log. A log has the columns of sim.hal's sampler, one row a servo period.
"""

import os
import subprocess
import sys
import time

import linuxcnc

command, status = linuxcnc.command(), linuxcnc.stat()


def wait(what, condition, seconds):
    """Waits until `condition` holds; the time is up after `seconds`."""
    end = time.monotonic() + seconds
    while time.monotonic() < end:
        status.poll()
        if condition():
            return
        error = errors.poll()
        if error:
            sys.exit(f"LinuxCNC: {error[1]}")
        time.sleep(0.01)
    sys.exit(f"{what}: not within {seconds} s")


def hal(*words):
    subprocess.run(["halcmd", *words], check=True)


def run(program, log):
    command.mode(linuxcnc.MODE_AUTO)
    command.wait_complete()
    command.program_open(program)
    command.wait_complete()
    with open(log, "wb") as out:
        sampler = subprocess.Popen(["halsampler"], stdout=out)
        hal("setp", "sampler.0.enable", "1")
        command.auto(linuxcnc.AUTO_RUN, 0)
        wait("start", lambda: status.interp_state != linuxcnc.INTERP_IDLE, 10)
        wait("program", lambda: status.interp_state == linuxcnc.INTERP_IDLE and status.inpos, 3600)
        time.sleep(0.3)
        hal("setp", "sampler.0.enable", "0")
        time.sleep(0.3)
        sampler.terminate()
        sampler.wait()


errors = linuxcnc.error_channel()
time.sleep(0.5)
command.state(linuxcnc.STATE_ESTOP_RESET)
command.wait_complete()
command.state(linuxcnc.STATE_ON)
command.wait_complete()
command.mode(linuxcnc.MODE_MANUAL)
command.wait_complete()
command.home(-1)
wait("homing", lambda: all(status.homed[:3]), 10)
with open(os.environ["PRECOMP_JOBS"], encoding="utf-8") as jobs:
    for job in jobs:
        run(*job.rstrip("\n").split("\t"))
