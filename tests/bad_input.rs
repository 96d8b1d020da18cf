//! Bad input: exact exit codes and messages, and nothing half-written.
