"""What the machine may do: limits and the governor that holds them."""
