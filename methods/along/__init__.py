"""What walks along a recording or an episode, whatever the method."""
