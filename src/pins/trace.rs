//! Keeps the conversation with a [`Pins`].
