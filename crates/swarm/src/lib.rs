//! Particles of emitters on a graphics device.
