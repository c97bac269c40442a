"""What a probe is good for: sigma from repeated touches, the effective radius of its tip from a reference ball."""
