"""The numerical stability suite: every solver on its hard cases, and whether what it says of its error is true."""
