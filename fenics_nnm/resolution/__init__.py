"""How fine a study has to be: harmonics, samples and modes that meet a tolerance."""
