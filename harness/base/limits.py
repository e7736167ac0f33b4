"""Limits on an FMU's resources: disk and memory before it runs, and those of its process while it runs."""

from typing import Annotated

from pydantic import BaseModel, Field, StrictInt

MIB = 1 << 20

Count = Annotated[StrictInt, Field(gt=0)]


class FmuLimits(BaseModel, frozen=True, extra="forbid", allow_inf_nan=False):
    """Limits for foreign FMUs; those from memory on apply only in a separate process.

    In memory modelDescription.xml takes thirty times its file size. Linux does not limit the processes of root.
    A plant whose calls take as long as `patience` would need hours for a stop.
    """

    files: Count = Field(default=10_000, description="maximum number of entries of the archive")
    unpacked_mib: Count = Field(default=2048, description="maximum unpacked size of all entries [MiB]")
    member_mib: Count = Field(default=1024, description="maximum unpacked size of one entry [MiB]")
    ratio: Count = Field(default=200, description="maximum ratio of unpacked to packed size beyond 16 MiB")
    description_mib: Count = Field(default=32, description="largest modelDescription.xml [MiB]")
    variables: Count = Field(default=100_000, description="most variables")
    memory_mib: Count = Field(default=1024, description="maximum address space of its process [MiB]")
    processes: Count = Field(default=256, description="maximum number of additional processes and threads")
    open_files: Count = Field(default=256, description="maximum number of open files")
    messages: Count = Field(default=1_000_000, description="maximum number of log messages")
    output_mib: Count = Field(
        default=64,
        description="maximum output to standard output and error of a run and its trial runs, and size of files [MiB]",
    )
    patience: float = Field(default=10.0, gt=0.0, description="maximum real time of one call, including the start [s]")
    budget: float = Field(
        default=3600.0, gt=0.0, description="maximum real time of all calls of a run, including trial runs [s]"
    )


FMU_LIMITS = FmuLimits()
