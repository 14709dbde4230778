"""What a simulated laser is and knows, apart from its line: the device on which requests act.

A laser keeps its `Eeprom` without power. All else is forgotten when it is switched off or reset, and is part of its
`Operation`, which exists only while the laser is ready.
"""

from dataclasses import dataclass, field
from typing import List, Optional

from ...lms2xx import (FACTORY, MEASURING_MODES, PASSWORD, SPEEDS, WELL, Availability, Configuration,
                       DeviceError, Indices, Mode, RawScan, Severity, Status, StatusReply, Variant)
from ..clock import NEVER_US, Clock
from .optics import Optics, PoseAt
from .raw_values import raw_values
from .ray_plans import RayPlan, complete_scan, partial_scan, quarter_of_turn

TURNS, TURNS_US = 3, 40000
"""Turns of the mirror, and the microseconds that they take: 75 turns a second, in whole numbers."""
FIRST_BAUD = 9600
"""Speed (baud) after power-on, unless the laser is told to keep another one (laser sheet 1.1)."""
FIRST_VARIANT = Variant(180, 50)
"""How the laser looks after power-on (laser sheet 1.10, example B1)."""
TURN_US_90THS = 148
"""What the laser says of its turn time in B1 (laser sheet 1.6)."""
STREAMS = frozenset((Mode.STREAM, Mode.STREAM_OF_A_PART, Mode.STREAM_OF_PARTIAL_SCANS))
"""Modes in which the laser sends scans by itself. It does not know the sheet's other ones."""


@dataclass(frozen=True)
class FirmwareNumbers:
    """How a laser behaves on its line. Times are in seconds."""

    boot: float = 30.0
    """From power-on, or from the end of reply 91, to telegram 90. Laser sheet part 5: at most 60, mostly 30..35."""
    mode_change: float = 0.05
    """Before reply A0. Sheet 1.2: up to 3 s; [inv]: below the 0.2 s after which one client sends the next request."""
    variant_change: float = 0.05
    """Before reply BB [inv], for the same reason."""
    eeprom_write: float = 0.15
    """Before replies F7 and E6. Sheet 1.2: up to 7 s; [inv], for the same reason."""
    other: float = 0.002
    """Before all other replies [inv]. Sheet 1.2: a scan within 0.06 s."""
    longest_gap: float = 0.006
    """Pause between two bytes of a request on a serial line, after which the laser drops it. Sheet 1.2."""
    longest_gap_elsewhere: float = 0.1
    """The same over TCP or a pseudo-terminal, where nobody keeps time [inv]."""
    missed: float = 0.0
    """Share (0..1) of the requests that the laser misses while it streams. Sheet 1.2: it happens; share [inv]."""
    identity: str = "LMS200;301063;V02.10 "
    """Type and version in 90 and BA. Sheet 1.3."""
    version: str = "V02.10 "
    """Version of firmware and PROM in B1. Sheet 1.6."""
    password: bytes = PASSWORD
    """Password of the installation mode. Sheet 1.4."""


@dataclass
class Eeprom:
    """What a laser keeps without power.

    Attributes:
        configuration: as command 77 wrote it.
        keeps_speed: whether `kept_baud` holds after power-on, as command 66 wrote it.
        kept_baud: speed (baud) at which the laser was told to keep it.
        writes: number of writes so far. An EEPROM lasts for a few thousand (laser sheet 1.2).
    """

    configuration: Configuration = FACTORY
    keeps_speed: bool = False
    kept_baud: int = FIRST_BAUD
    writes: int = 0

    @property
    def power_on_baud(self) -> int:
        """The speed (baud) after power-on."""
        return self.kept_baud if self.keeps_speed else FIRST_BAUD


@dataclass
class Operation:
    """What a laser knows while it is ready.

    Attributes:
        ready_us: time at which it became ready (microseconds). The turns of its mirror count from here.
        mode: present `Mode`.
        part: numbers, from 1 on, of the first and the last value in mode STREAM_OF_A_PART. Else all.
        variant: how wide and how fine it looks.
        since_us: time of the last change of mode or variant. A streamed scan does not begin before it.
        scans_sent: number of telegrams with scans, for their index.
    """

    ready_us: int
    mode: int = Mode.ON_REQUEST
    part: slice = field(default_factory=lambda: slice(None))
    variant: Variant = FIRST_VARIANT
    since_us: int = 0
    scans_sent: int = 0

    def turns_ended(self, now_us: int) -> int:
        """Return how many turns of the mirror have ended until `now_us` (microseconds)."""
        return (now_us - self.ready_us) * TURNS // TURNS_US

    def turn_end_us(self, number: int) -> int:
        """Return when a turn ends (microseconds). `number` counts from 1 on; 0 gives the start of the first turn."""
        return self.ready_us - -number * TURNS_US // TURNS

    def next_turn_us(self, now_us: int) -> int:
        """Return the end of the first turn that ends after `now_us` (microseconds). `NEVER_US` if nothing is streamed.
        """
        return self.turn_end_us(self.turns_ended(now_us) + 1) if self.mode in STREAMS else NEVER_US


class LaserDevice:
    """One laser without its line.

    Args:
        optics: what it measures with.
        pose_at: returns its pose at a time.
        clock: clock of the simulated time.
        numbers: how it behaves.
        address: its address, 0..127.
        fixed_baud: speed of its line, which then never changes. None: a client changes it.

    Attributes:
        numbers, clock, address, fixed_baud: as the arguments.
        eeprom: what it keeps without power.
        operation: what it knows while it is ready. None while it is off, or starts.
        baud: present speed of its serial line.
        errors: its errors. A test may change the list.
        dirty_window: whether its window is dirty. A test may change it.
    """

    def __init__(self, optics: Optics, pose_at: PoseAt, clock: Clock, numbers: FirmwareNumbers, address: int,
                 fixed_baud: Optional[int] = None):
        self.numbers, self.clock, self.address, self.fixed_baud = numbers, clock, address, fixed_baud
        self._optics, self._pose_at = optics, pose_at
        self.eeprom = Eeprom()
        self.operation: Optional[Operation] = None
        self.baud = self.power_on_baud
        self.errors: List[DeviceError] = []
        self.dirty_window = False

    @property
    def power_on_baud(self) -> int:
        """The speed (baud) after power-on."""
        return self.fixed_baud or self.eeprom.power_on_baud

    @property
    def status(self) -> int:
        """The status byte of each reply (laser sheet 1.1): its worst present error, and whether its window is dirty."""
        worst = max((error.severity for error in self.errors if not error.is_old), default=Severity.OK)
        return WELL | worst | (Status.DIRTY_WINDOW if self.dirty_window else 0)

    def status_reply(self, operation: Operation) -> StatusReply:
        """Return all that the laser says of itself. What the sheet calls reserved is 0, as in its example."""
        configuration = self.eeprom.configuration
        return StatusReply(
            version=self.numbers.version,
            mode=operation.mode,
            defect=int(any(error.severity == Severity.FATAL and not error.is_old for error in self.errors)),
            reserved_10=(0,) * 8,
            variant=0,
            reserved_19=(0,) * 48,
            turn_us_90ths=TURN_US_90THS,
            reserved_69=(0,) * 33,
            measuring_mode=configuration.measuring_mode,
            reserved_103=(0,) * 4,
            angle_deg=operation.variant.angle_deg,
            step_hundredths=operation.variant.step_hundredths,
            restart=configuration.restart or 0,
            reserved_112=(0,) * 4,
            speed_word=SPEEDS[self.baud].word,
            reserved_118=2,
            keeps_speed=int(self.eeprom.keeps_speed),
            address=self.address,
            reserved_121=0,
            unit=configuration.unit,
            laser=1,
            prom_version=self.numbers.version,
            reserved_131=(0,) * 22)

    def scan(self, operation: Operation, last_turn: int, values: slice = slice(None)) -> RawScan:
        """Return the complete scan whose last turn is `last_turn` (from 1 on).

        Args:
            operation: the laser's present operation.
            last_turn: number of its last turn.
            values: which of its values to return.
        """
        return self._measured(operation, complete_scan(operation.variant), last_turn, values)

    def partial_scan(self, operation: Operation, turn: int) -> RawScan:
        """Return the rays of one turn (from 1 on) alone."""
        quarter = quarter_of_turn(operation.variant, (turn - 1) % operation.variant.turns)
        scan = self._measured(operation, partial_scan(quarter), turn, slice(None))
        return scan._replace(partial=True, quarter=quarter)

    def _measured(self, operation: Operation, plan: RayPlan, last_turn: int, values: slice) -> RawScan:
        begin_us = max(0, operation.turn_end_us(last_turn - plan.turns))
        measured = self._optics.measure(plan, begin_us * 1e-6, self._pose_at)
        configuration = self.eeprom.configuration
        indices = None
        if configuration.availability & Availability.INDICES:
            indices = Indices(last_turn % 256, operation.scans_sent % 256)
        operation.scans_sent += 1
        mode = MEASURING_MODES[configuration.measuring_mode]
        return RawScan(raw_values(measured, mode, configuration.unit)[values], configuration.unit, indices=indices)
