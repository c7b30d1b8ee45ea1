"""Stress and life under load: forces, Hertz contact, fatigue, bearings."""
