"""What an FMU may take: of disk and memory before it runs, and of the machine while it does."""

from dataclasses import dataclass, fields

MIB = 1 << 20


@dataclass(frozen=True, slots=True, kw_only=True)
class FmuLimits:
    """Limits for FMUs from outside; those from memory on hold in a process of its own only.

    Attributes:
        files: Most entries of the archive.
        unpacked_mib: Most that they unpack to, together [MiB].
        member_mib: Most that one of them unpacks to [MiB].
        ratio: Most times that the archive grows when it is unpacked to more than 16 MiB.
        description_mib: Largest modelDescription.xml [MiB]; in memory it takes thirty times that.
        variables: Most variables.
        memory_mib: Most address space of its process [MiB].
        processes: Most processes and threads it may add to those of its user; Linux does not hold root to it.
        open_files: Most files open at once.
        messages: Most messages it may log in all.
        output_mib: Most that it may write to standard output and error together, and to any one file [MiB].
        patience: Real time one call may last, starting included [s]; a plant this slow would need hours for a stop.
    """

    files: int = 10_000
    unpacked_mib: int = 2048
    member_mib: int = 1024
    ratio: int = 200
    description_mib: int = 32
    variables: int = 100_000
    memory_mib: int = 1024
    processes: int = 256
    open_files: int = 256
    messages: int = 1_000_000
    output_mib: int = 64
    patience: float = 10.0

    def __post_init__(self) -> None:
        """Refuse what is not positive."""
        for field in fields(self):
            value = getattr(self, field.name)
            if not 0 < value < float("inf"):
                raise ValueError(f"{field.name} is a positive number, got {value}")


FMU_LIMITS = FmuLimits()
