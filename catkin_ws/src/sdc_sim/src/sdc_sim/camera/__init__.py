"""Front camera: renders the road, the scenery and the traffic, and publishes the pictures."""
