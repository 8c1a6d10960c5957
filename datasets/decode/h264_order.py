"""Whether H.264 packets follow each other, or some were lost: decoders go on without them and show stale pictures.

Reference: ITU-T H.264, 7.3.2.1.1 (sequence parameter set), 7.3.3 (slice header), 7.4.3 (frame_num).
"""

_WITH_CHROMA = (100, 110, 122, 244, 44, 83, 86, 118, 128, 138, 139, 134, 135)
"""Profiles whose parameter sets describe chroma and scaling."""
_BYTES_LOOKED_AT = 64


class H264Order:
    """Follows the numbers of pictures that later ones refer to."""

    def __init__(self) -> None:
        self._bits = 0
        self._planes = False
        self._gaps_allowed = False
        self._last = 0
        self._last_is_referred = False

    def follows(self, sps: bytes, slice_: bytes) -> bool:
        """Whether nothing is missing before a packet, by its sequence parameter set, if it has one, and first slice.

        Damage counts as nothing missing: the decoder has the word.
        """
        try:
            if sps:
                self._read_parameters(_Bits(sps[1:]))
            return self._read_slice(slice_) if slice_ and self._bits else True
        except IndexError:
            return True

    def _read_slice(self, slice_: bytes) -> bool:
        kind, referred = slice_[0] & 0x1F, bool(slice_[0] & 0x60)
        bits = _Bits(slice_[1:])
        bits.skip_numbers(3)  # first macroblock, kind of slice, parameter set
        if self._planes:
            bits.read(2)
        number = bits.read(self._bits)
        most = 1 << self._bits
        # A picture has the number behind the last one that is referred to; that one's own second field has its number.
        due = (self._last + 1) % most if self._last_is_referred else self._last
        follows = kind == 5 or self._gaps_allowed or number in (due, self._last)
        self._last, self._last_is_referred = number, referred
        return follows

    def _read_parameters(self, bits: "_Bits") -> None:
        profile = bits.read(8)
        bits.read(16)  # constraints, level
        bits.skip_numbers(1)
        self._planes = False
        if profile in _WITH_CHROMA:
            if bits.number() == 3:
                self._planes = bool(bits.read(1))
                lists = 12
            else:
                lists = 8
            bits.skip_numbers(2)
            bits.read(1)
            if bits.read(1):
                _skip_scaling(bits, lists)
        self._bits = bits.number() + 4
        order = bits.number()
        if order == 0:
            bits.skip_numbers(1)
        elif order == 1:
            bits.read(1)
            bits.skip_numbers(2)
            bits.skip_numbers(bits.number())
        bits.skip_numbers(1)
        self._gaps_allowed = bool(bits.read(1))


def _skip_scaling(bits: "_Bits", lists: int) -> None:
    for place in range(lists):
        if not bits.read(1):
            continue
        last = following = 8
        for _ in range(16 if place < 6 else 64):
            if following:
                following = (last + bits.signed_number()) % 256
            last = following or last


class _Bits:
    """Reads a unit bit by bit; the bytes that keep it free of start codes are left out.

    Raises:
        IndexError: It ends before.
    """

    def __init__(self, data: bytes) -> None:
        content = data[:_BYTES_LOOKED_AT].replace(b"\0\0\3", b"\0\0")
        self._value, self._left = int.from_bytes(content), 8 * len(content)

    def read(self, count: int) -> int:
        """An unsigned number of so many bits."""
        self._left -= count
        if self._left < 0:
            raise IndexError("the unit ends here")
        return (self._value >> self._left) & ((1 << count) - 1)

    def number(self) -> int:
        """An unsigned Exp-Golomb number (9.1)."""
        zeros = 0
        while not self.read(1):
            zeros += 1
        return (1 << zeros) - 1 + self.read(zeros)

    def signed_number(self) -> int:
        """A signed Exp-Golomb number (9.1.1)."""
        number = self.number()
        return (number + 1) // 2 if number % 2 else -number // 2

    def skip_numbers(self, count: int) -> None:
        """Leave out so many Exp-Golomb numbers."""
        for _ in range(count):
            self.number()
