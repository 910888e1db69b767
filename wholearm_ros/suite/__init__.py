"""Many scenarios planned and executed without ROS, and what came of them."""
