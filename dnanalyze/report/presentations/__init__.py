"""How each type of result looks, in the file of the type's name."""
