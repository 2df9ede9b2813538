"""Settings from outside: TOML files and names, checked once where they enter.

`validation` turns a mapping into a settings record, `toml_file` reads the mapping from a file,
`choice` picks one of several things by name. Whatever is wrong becomes one plain line, an
`InputError`. Below this room nothing checks a setting again.
"""
