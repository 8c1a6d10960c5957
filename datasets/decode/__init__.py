"""From message objects to the arrays navtool works with, one file a kind of message."""
