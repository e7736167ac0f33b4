"""Export a scenario to other tools: controller, plant or other parts as FMUs, a static library, or a system of FMUs."""
