"""What stands between a wish to move and the wheels."""
