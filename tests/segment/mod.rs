//! What is connected, and surfaces of fields, against plain reckoning.

mod components;
mod joined;
