"""Several sensors side by side: their figures, at common temperatures, ranked per criterion."""
