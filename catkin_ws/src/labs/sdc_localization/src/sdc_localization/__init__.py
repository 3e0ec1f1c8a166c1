"""Where is the car? An extended Kalman filter of wheel speeds, gyroscope, GNSS and landmarks."""
