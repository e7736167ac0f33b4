"""The platform and the exports of a shared library, read from its bytes: ELF, PE and Mach-O."""

import struct

_ELF_MACHINES = {62: "x86_64", 183: "aarch64"}
_MACH_MACHINES = {0x01000007: "x86_64", 0x0100000C: "aarch64"}


def described(content):
    """Return the platform of a shared library as FMI 3 names it, and the names that it exports."""
    if content[:4] == b"\x7fELF":
        return _elf(content)
    return _pe(content) if content[:2] == b"MZ" else _mach(content)


def _text(content, at):
    return content[at : content.index(b"\0", at)].decode()


def _elf(content):
    (machine,), (sections,) = struct.unpack_from("<H", content, 18), struct.unpack_from("<Q", content, 40)
    size, count = struct.unpack_from("<HH", content, 58)
    headers = [struct.unpack_from("<IIQQQQIIQQ", content, sections + k * size) for k in range(count)]
    names = set()
    for kind, at, length, link in ((h[1], h[4], h[5], h[6]) for h in headers):
        if kind == 11:  # dynamic symbols
            for place in range(at, at + length, 24):
                name, info, _, section = struct.unpack_from("<IBBH", content, place)
                if section and info >> 4 == 1:  # defined here, global
                    names.add(_text(content, headers[link][4] + name))
    return f"{_ELF_MACHINES[machine]}-linux", names


def _pe(content):
    (at,) = struct.unpack_from("<I", content, 60)
    machine, count = struct.unpack_from("<HH", content, at + 4)
    (length,) = struct.unpack_from("<H", content, at + 20)
    assert (machine, content[at : at + 4]) == (0x8664, b"PE\0\0")
    (exports,) = struct.unpack_from("<I", content, at + 24 + 112)
    sections = [struct.unpack_from("<8x4I", content, at + 24 + length + 40 * k) for k in range(count)]

    def place(address):
        return next(raw + address - begin for size, begin, _, raw in sections if begin <= address < begin + size)

    number, _, names = struct.unpack_from("<III", content, place(exports) + 24)
    starts = struct.unpack_from(f"<{number}I", content, place(names))
    return "x86_64-windows", {_text(content, place(start)) for start in starts}


def _mach(content):
    magic, machine, _, kind, commands = struct.unpack_from("<5I", content)
    assert (magic, kind) == (0xFEEDFACF, 6)  # 64 bits, a shared library
    names, at = set(), 32
    for _ in range(commands):
        command, size = struct.unpack_from("<II", content, at)
        if command == 2:  # symbol table
            symbols, count, texts, _ = struct.unpack_from("<4I", content, at + 8)
            for k in range(count):
                name, type_ = struct.unpack_from("<IB", content, symbols + 16 * k)
                if type_ & 0x1F == 0x0F:  # defined here, external
                    names.add(_text(content, texts + name).removeprefix("_"))
        at += size
    return f"{_MACH_MACHINES[machine]}-darwin", names
