"""Labels of rows: rules, events files, known steps, and writing them into a data set."""
