"""Choosing contacts: what there is to choose from, what a choice is worth, the best choice, and if it is unique."""
