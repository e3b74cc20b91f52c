"""A robot in the browser that plans while targets and obstacles are dragged, and follows them."""
