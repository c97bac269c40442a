"""The mistakes that cells make: done to contacts on purpose, and looked for where no pose explains them."""
