"""The extended Kalman filter: covariance algebra, the bank of filters, start-up and consistency."""
