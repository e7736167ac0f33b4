"""How long things take: medians and ratios of paired runs, so that a busy machine moves both sides alike."""
