"""What the vehicle reports: pose, odometry, health, target, time, and when each message is sent."""
