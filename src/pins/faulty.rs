//! Seeded fault injection over a [`Pins`].
