"""What we do about it: wheel-slide control laws, from reading and belief to brake command."""
