//! Pictures against references, and relations between pictures.
