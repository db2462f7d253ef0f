"""The nonlinear mode: its branch over energy or frequency, and what is known of each point."""
