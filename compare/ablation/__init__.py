"""What leaving out pays."""
