"""The front door of the library: what `import sternplane` offers."""
