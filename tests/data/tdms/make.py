"""Writes the TDMS files of this folder, and truth.json: what npTDMS reads in them, bit by bit.

Renew with npTDMS 1.13.0 and NumPy 2: python3 make.py
What npTDMS cannot write (big-endian, interleaved and unclosed segments, lists that change) is packed
here, and read by npTDMS all the same.
"""

import json
import struct
from datetime import datetime, timedelta
from pathlib import Path

import numpy as np
from nptdms import ChannelObject, GroupObject, RootObject, TdmsFile, TdmsWriter

HERE = Path(__file__).parent
K = np.arange(48)
PULSE = np.round(-30.0 * np.exp(-(((K - 20) / 6.0) ** 2)) * 1000) / 1000 + 0.01 * np.sin(K)
CLOCK = {"wf_increment": 1e-4, "wf_start_offset": -1e-3, "wf_samples": 1}
G = {"unit_string": "g", **CLOCK}


def linear(slope, intercept, source=0xFFFFFFFF, at=0):
    start = f"NI_Scale[{at}]_"
    return {
        start + "Scale_Type": "Linear",
        start + "Linear_Slope": slope,
        start + "Linear_Y_Intercept": intercept,
        start + "Linear_Input_Source": np.uint32(source),
    }


def polynomial(coefficients, source=0xFFFFFFFF, at=0):
    start = f"NI_Scale[{at}]_"
    named = {f"{start}Polynomial_Coefficients[{i}]": c for i, c in enumerate(coefficients)}
    return {
        start + "Scale_Type": "Polynomial",
        start + "Polynomial_Coefficients_Size": np.uint32(len(coefficients)),
        start + "Polynomial_Input_Source": np.uint32(source),
        **named,
    }


COUNTS = np.round(PULSE * 400).astype(np.int16)
SCALED = {"NI_Number_Of_Scales": np.uint32(1), "NI_Scaling_Status": "unscaled"}
TWICE = {"NI_Number_Of_Scales": np.uint32(2), "NI_Scaling_Status": "unscaled"}


def plain():
    root = RootObject({"name": "plain", "title": "side impact", "author": "A. Lab", "datetime": datetime(2026, 1, 15, 10, 0)})
    group = GroupObject("Vehicle", {"description": "left side struck"})
    return [
        [
            root,
            group,
            ChannelObject("Vehicle", "door y", PULSE, {**G, "description": "B-pillar, lower"}),
            ChannelObject("Vehicle", "door x", PULSE.astype(np.float32), G),
            ChannelObject("Vehicle", "door z", COUNTS, {**G, **SCALED, **linear(0.0025, 0.5)}),
            ChannelObject("Vehicle", "sill x", COUNTS, {**G, **SCALED, **polynomial([0.1, 0.0025, 1e-9])}),
            ChannelObject("Vehicle", "sill z", COUNTS, {**G, **TWICE, **linear(3.0, 1.0), **polynomial([0.1, 0.002], 0, 1)}),
            ChannelObject("Vehicle", "roof z", COUNTS, {**G, **SCALED, "NI_Scaling_Status": "scaled", **linear(7.0, 9.0)}),
            ChannelObject("Vehicle", "notes", ["ready", "contact", "", "end"]),
        ]
    ]


def types():
    kinds = [np.int8, np.int16, np.int32, np.int64, np.uint8, np.uint16, np.uint32, np.uint64, np.float32, np.float64]
    return [[ChannelObject("all", np.dtype(kind).name, (K * 2 + 1).astype(kind), G) for kind in kinds]]


def segments():
    first = [ChannelObject("g", "door y", PULSE[:10], G), ChannelObject("g", "door x", COUNTS[:10], G)]
    rest = [
        [ChannelObject("g", "door y", PULSE[i : i + 4]), ChannelObject("g", "door x", COUNTS[i : i + 4])]
        for i in range(10, 46, 4)
    ]
    late = [ChannelObject("g", "door y", PULSE[46:]), ChannelObject("late", "roof x", PULSE[:30], G)]
    return [first, *rest, late]


def stamps():
    start = datetime(2026, 1, 15, 10, 0)
    times = [np.datetime64(start + timedelta(microseconds=100 * int(k)), "us") for k in K]
    return [[ChannelObject("g", "Time", np.array(times)), ChannelObject("g", "door y", PULSE, {"unit_string": "m/s^2"})]]


def text(order, words):
    raw = words.encode()
    return struct.pack(order + "L", len(raw)) + raw


CODES = {"int16": 2, "int32": 3, "float32": 9, "float64": 10}


def value(order, key, said):
    if isinstance(said, str):
        return text(order, key) + struct.pack(order + "L", 0x20) + text(order, said)
    return text(order, key) + struct.pack(order + "Ld", 10, float(said))


def entry(order, path, index, properties):
    """An object of a list: index is None for no samples, 0 for as before, or type and number."""
    out = text(order, path)
    if index is None:
        out += struct.pack(order + "L", 0xFFFFFFFF)
    elif index == 0:
        out += struct.pack(order + "L", 0)
    else:
        out += struct.pack(order + "LLLQ", 20, CODES[index[0]], 1, index[1])
    out += struct.pack(order + "L", len(properties))
    return out + b"".join(value(order, *pair) for pair in properties.items())


def segment(order, objects, data, interleaved=False, new_list=True, unclosed=False):
    meta = b"" if objects is None else struct.pack(order + "L", len(objects)) + b"".join(entry(order, *o) for o in objects)
    flags = (2 if objects is not None else 0) | (4 if new_list and objects is not None else 0) | (8 if data else 0)
    flags |= (32 if interleaved else 0) | (64 if order == ">" else 0)
    end = 0xFFFFFFFFFFFFFFFF if unclosed else len(meta) + len(data)
    return b"TDSm" + struct.pack("<L", flags) + struct.pack(order + "LQQ", 4713, end, len(meta)) + meta + data


def packed(order, array):
    return array.astype(array.dtype.newbyteorder(order)).tobytes()


Y, X, Z = "/'it''s'/'door y'", "/'it''s'/'door x'", "/'it''s'/'door z'"
F32 = PULSE.astype(np.float32)


def big_endian():
    objects = [("/", None, {"title": "big"}), (Y, ("float64", 48), G), (X, ("int16", 48), G), (Z, ("float32", 48), G)]
    return segment(">", objects, packed(">", PULSE) + packed(">", COUNTS) + packed(">", F32))


def rows(order, start, stop):
    return b"".join(packed(order, PULSE[i : i + 1]) + packed(order, COUNTS[i : i + 1]) + packed(order, F32[i : i + 1]) for i in range(start, stop))


def interleaved(order):
    objects = [(Y, ("float64", 12), G), (X, ("int16", 12), G), (Z, ("float32", 12), G)]
    # Three chunks of twelve rows, then one more segment without a list.
    return segment(order, objects, rows(order, 0, 36), True) + segment(order, None, rows(order, 36, 48), True)


def lists():
    """Lists that change: as before, without samples, appended, a new order, another byte order."""
    little, big = "<", ">"
    parts = [
        segment(little, [(Y, ("float64", 4), G), (X, ("int16", 4), G)], packed(little, PULSE[:4]) + packed(little, COUNTS[:4])),
        segment(little, None, packed(little, PULSE[4:8]) + packed(little, COUNTS[4:8]) + packed(little, PULSE[8:12]) + packed(little, COUNTS[8:12])),
        segment(little, [(X, None, {})], packed(little, PULSE[12:16]), new_list=False),
        segment(big, [(X, 0, {"comment": "back again"}), (Z, ("float32", 2), G)], packed(big, PULSE[16:20]) + packed(big, COUNTS[12:16]) + packed(big, F32[:2]), new_list=False),
        segment(little, [(Z, 0, {}), (Y, ("float64", 28), {})], packed(little, F32[2:4]) + packed(little, PULSE[20:48])),
        segment(little, [("/", None, {"title": "told at the end"})], b""),
    ]
    return b"".join(parts)


def unclosed():
    objects = [(Y, ("float64", 8), G), (X, ("int16", 8), G)]
    whole = segment("<", objects, packed("<", PULSE[:8]) + packed("<", COUNTS[:8]))
    data = packed("<", PULSE[8:16]) + packed("<", COUNTS[8:16]) + packed("<", PULSE[16:21]) + b"\1\2\3"
    return whole + segment("<", None, data, unclosed=True)


def main():
    written = {"plain": plain(), "types": types(), "segments": segments(), "stamps": stamps()}
    for name, parts in written.items():
        with TdmsWriter(HERE / f"{name}.tdms") as writer:
            for part in parts:
                writer.write_segment(part)
    own = {
        "big-endian": big_endian(),
        "interleaved": interleaved("<"),
        "interleaved-big-endian": interleaved(">"),
        "lists": lists(),
        "unclosed": unclosed(),
    }
    for name, content in own.items():
        (HERE / f"{name}.tdms").write_bytes(content)
    truth = []
    for path in sorted(HERE.glob("*.tdms")):
        file = TdmsFile.read(path)
        for group in file.groups():
            for channel in group.channels():
                if channel.dtype.kind not in "iuf" or channel.name == "Time":
                    continue
                bits = [struct.pack(">d", float(v)).hex() for v in channel[:]]
                truth.append({"file": path.name, "group": group.name, "channel": channel.name, "bits": bits})
    (HERE / "truth.json").write_text(json.dumps(truth, indent=0) + "\n")


main()
