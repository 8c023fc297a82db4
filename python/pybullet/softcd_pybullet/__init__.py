"""The folder of softcd's plugin for PyBullet. softcd.bullet.attach() loads the plugin."""
