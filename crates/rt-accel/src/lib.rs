//! rt-accel
