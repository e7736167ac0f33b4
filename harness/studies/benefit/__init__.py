"""Seconds of headway that sand, slide protection or track brakes buy on a line, through ETCS braking curves."""
