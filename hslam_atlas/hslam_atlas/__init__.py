"""Edge-maps to an atlas: matching, loop closing, optimisation, planning, exploration."""
