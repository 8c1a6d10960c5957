"""The simulated outdoors: what stands where, what it is made of, and what a ray meets."""
