//! The command line's promises, one file each, tested by running the command.
