#!/usr/bin/env python3
"""Watches `gaitshift view` for a long time: memory, drift against the clock, evenness of its messages, processor share.

    benchmarks/view_soak.py PROGRAM [--minutes 30] [--tabs 1]

Needs the package `websockets`, Linux, and a program built in the release profile. Prints one JSON object.
"""

import argparse
import asyncio
import json
import os
import struct
import subprocess
import time

from websockets.asyncio.client import connect


def resident_kb(pid):
    with open(f"/proc/{pid}/status", encoding="ascii") as status:
        return next(int(line.split()[1]) for line in status if line.startswith("VmRSS"))


def processor_s(pid):
    with open(f"/proc/{pid}/stat", encoding="ascii") as stat:
        fields = stat.read().rsplit(")", 1)[1].split()
    return (int(fields[11]) + int(fields[12])) / os.sysconf("SC_CLK_TCK")


async def tab(url, end, seen):
    """Takes everything a tab is sent, moving the slider once a minute; notes when samples came and what time they show."""
    async with connect(url.replace("http", "ws") + "socket", max_size=None) as socket:
        last, moved, level = None, 0.0, 0
        while (now := time.monotonic()) < end:
            message = await socket.recv()
            now = time.monotonic()
            if isinstance(message, str):
                told = json.loads(message)
                if told["type"] == "now":
                    seen["behind_s"], seen["dropped"] = told["behind_s"], told["dropped"]
                    seen["falls"] += told["epoch"] != seen["epoch"]
                    seen["epoch"] = told["epoch"]
            else:
                if last is not None:
                    seen["gaps_s"].append(now - last)
                last = now
                count = struct.unpack_from("<I", message, 8)[0]
                size = (len(message) - 12) // count
                shown_s = struct.unpack_from("<d", message, 12 + (count - 1) * size)[0]
                seen["first"] = seen["first"] or (now, shown_s)
                seen["last"] = (now, shown_s)
            if now - moved > 60:
                moved, level = now, level + 1
                await socket.send(json.dumps({"type": "omega_v", "value": [0.0, 3.0, 1.5][level % 3]}))


async def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("program")
    parser.add_argument("--minutes", type=float, default=30)
    parser.add_argument("--tabs", type=int, default=1)
    arguments = parser.parse_args()
    command = [arguments.program, "view", "--no-open", "--port", "0"]
    process = subprocess.Popen(command, stdout=subprocess.PIPE, text=True)
    try:
        url = process.stdout.readline().split()[0]
        end = time.monotonic() + 60 * arguments.minutes
        tabs = [
            {"gaps_s": [], "first": None, "last": None, "behind_s": 0, "dropped": 0, "falls": 0, "epoch": 0}
            for _ in range(arguments.tabs)
        ]
        tasks = [asyncio.create_task(tab(url, end, seen)) for seen in tabs]
        memory_kb = []
        await asyncio.sleep(min(70, 20 * arguments.minutes))
        begin, begin_s = time.monotonic(), processor_s(process.pid)
        while time.monotonic() < end:
            memory_kb.append(resident_kb(process.pid))
            await asyncio.sleep(min(30, max(0.5, 6 * arguments.minutes)))
        share = (processor_s(process.pid) - begin_s) / (time.monotonic() - begin)
        await asyncio.gather(*tasks)
    finally:
        process.kill()
    seen = tabs[0]
    gaps_ms = sorted(1000 * gap for gap in seen["gaps_s"])
    (t0, s0), (t1, s1) = seen["first"], seen["last"]
    figures = {
        "minutes": arguments.minutes,
        "tabs": arguments.tabs,
        "memory_first_kb": memory_kb[0],
        "memory_last_kb": memory_kb[-1],
        "memory_most_kb": max(memory_kb),
        "clock_s": round(t1 - t0, 3),
        "motion_s": round(s1 - s0, 3),
        "left_out_s": seen["behind_s"],
        "samples_dropped": seen["dropped"],
        "falls": seen["falls"],
        "messages": len(gaps_ms),
        "gap_median_ms": round(gaps_ms[len(gaps_ms) // 2], 2),
        "gap_p99_ms": round(gaps_ms[int(0.99 * len(gaps_ms))], 2),
        "gap_most_ms": round(gaps_ms[-1], 2),
        "processor_share_of_one_core": round(share, 4),
    }
    print(json.dumps(figures))


asyncio.run(main())
