"""The onboard part on a Cortex-M7: memory, instructions and outputs of cases in an emulator."""
