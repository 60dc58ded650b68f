"""CRC-16-IBM (polynomial 0x8005, reflected), also of each stretch of bytes from those of what is before it.

The register is linear over GF(2): the CRC up to the end of a stretch is that of the stretch, exclusive or what as many
zeros would have made of the CRC up to its beginning.
"""

from __future__ import annotations


def crc16(data: bytes) -> int:
    """Return the CRC-16-IBM of some bytes."""
    return sums(data, 0)[-1] if data else 0


def sums(data: bytes, crc: int) -> list[int]:
    """Return the CRC after each byte. crc: that of the bytes before."""
    found = []
    for byte in data:
        crc = (crc >> 8) ^ _CRC[(crc ^ byte) & 0xFF]
        found.append(crc)
    return found


def after_zeros(crc: int, count: int) -> int:
    """Return the CRC of bytes with this CRC and so many zeros behind them, fewer than 131072."""
    for k, columns in enumerate(_ZEROS):
        if count >> k & 1:
            crc = _times(columns, crc)
    return crc


def _times(columns: tuple[int, ...], crc: int) -> int:
    product = 0
    for bit, column in enumerate(columns):
        if crc >> bit & 1:
            product ^= column
    return product


def _of_byte(byte: int) -> int:
    for _ in range(8):
        byte = (byte >> 1) ^ (0xA001 if byte & 1 else 0)
    return byte


def _powers(count: int) -> tuple[tuple[int, ...], ...]:
    """Return what 2**k zeros, for k below count, do to a CRC: a matrix over GF(2), as 16 columns."""
    found = [tuple(((1 << bit) >> 8) ^ _CRC[(1 << bit) & 0xFF] for bit in range(16))]
    while len(found) < count:
        found.append(tuple(_times(found[-1], column) for column in found[-1]))
    return tuple(found)


_CRC = tuple(_of_byte(each) for each in range(256))
_ZEROS = _powers(17)  # for the longest packet, of 65555 bytes before its check sum
