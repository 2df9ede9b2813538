"""What stands between the network and the console: it lets through what can be meant well."""
